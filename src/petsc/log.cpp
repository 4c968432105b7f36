#include "stylet/petsc/log.hpp"

namespace stylet {

namespace {
PetscClassId class_id() {
  static PetscClassId id = [] {
    PetscClassId made = 0;
    check(PetscClassIdRegister("Stylet", &made));
    return made;
  }();
  return id;
}
}  // namespace

LogEvent::LogEvent(const char* name) {
  check(PetscLogEventRegister(name, class_id(), &id_));
}

int event_count(const std::string& name) {
  PetscLogEvent id = 0;
  check(PetscLogEventGetId(name.c_str(), &id));
  if (id < 0) return 0;
  PetscEventPerfInfo info;
  check(PetscLogEventGetPerfInfo(PETSC_DETERMINE, id, &info));
  return info.count;
}

}  // namespace stylet
