#include "stylet/dynamics/central_difference_ts.hpp"

#include "stylet/petsc/check.hpp"

// The only place that knows PETSc's private TS structure; tests/physics/central_difference_ts_test.cpp
// shows whether a release of PETSc still has it so.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#include <petsc/private/tsimpl.h>
#pragma GCC diagnostic pop

namespace stylet {

namespace {

struct Data {
  ExplicitStep step;
};

Data& data_of(TS ts) {
  return *static_cast<Data*>(ts->data);
}

PetscErrorCode step(TS ts) {
  return guard([&] {
    data_of(ts).step(ts->time_step, ts->vec_sol, ts->vec_dot);
    ts->ptime += ts->time_step;
  });
}

PetscErrorCode destroy(TS ts) {
  delete static_cast<Data*>(ts->data);
  ts->data = nullptr;
  return PetscErrorCode{};
}

PetscErrorCode create(TS ts) {
  return guard([&] {
    ts->data = new Data;
    ts->ops->step = step;
    ts->ops->destroy = destroy;
    ts->usessnes = PETSC_FALSE;
  });
}

}  // namespace

void register_central_difference() {
  check(TSRegister(central_difference_type, create));
}

void set_step(TS ts, ExplicitStep step) {
  data_of(ts).step = std::move(step);
}

}  // namespace stylet
