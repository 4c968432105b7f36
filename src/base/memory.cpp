#include "stylet/base/memory.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <sys/resource.h>
#include <sys/sysinfo.h>

namespace stylet {

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The number in a file that holds nothing else; "max" is none.
double limit_in(const std::string& path) {
  double bytes = 0;
  return std::ifstream(path) >> bytes ? bytes : unlimited;
}

}  // namespace

double memory_here() {
  double bytes = unlimited;
  struct sysinfo machine {};
  if (::sysinfo(&machine) == 0) {
    bytes = (static_cast<double>(machine.totalram) + static_cast<double>(machine.totalswap)) *
            machine.mem_unit;
  }
  // Inside a container the files of its own control group are at the top.
  bytes = std::min(bytes, limit_in("/sys/fs/cgroup/memory.max"));
  bytes = std::min(bytes, limit_in("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
  struct rlimit own {};
  if (::getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY) {
    bytes = std::min(bytes, static_cast<double>(own.rlim_cur));
  }
  return bytes;
}

}  // namespace stylet
