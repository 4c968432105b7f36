#include "stylet/dynamics/central_difference_ts.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/owned.hpp"

#include <petscversion.h>
// The only place that knows PETSc's private TS structure; checked for the release it was read from.
#if !PETSC_VERSION_(3, 18, 5) && !(PETSC_VERSION_MAJOR == 3 && PETSC_VERSION_MINOR == 18)
#error "central_difference_ts.cpp: check petsc/private/tsimpl.h of this PETSc release"
#endif
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#include <petsc/private/tsimpl.h>
#pragma GCC diagnostic pop

namespace stylet {

namespace {

struct Data {
  Acceleration acceleration;
  Vec a = nullptr;
  OwnedVec v_half;
};

Data& data_of(TS ts) {
  return *static_cast<Data*>(ts->data);
}

PetscErrorCode step(TS ts) {
  return guard([&] {
    Data& d = data_of(ts);
    const double h = ts->time_step;
    Vec u = ts->vec_sol;
    Vec v = ts->vec_dot;
    check(VecWAXPY(d.v_half.get(), h / 2, d.a, v));
    check(VecAXPY(u, h, d.v_half.get()));
    d.acceleration(ts->ptime + h, u, d.v_half.get(), d.a);
    check(VecWAXPY(v, h / 2, d.a, d.v_half.get()));
    ts->ptime += h;
  });
}

PetscErrorCode set_up(TS ts) {
  return guard([&] { check(VecDuplicate(ts->vec_sol, data_of(ts).v_half.put())); });
}

PetscErrorCode destroy(TS ts) {
  delete static_cast<Data*>(ts->data);
  ts->data = nullptr;
  return 0;
}

PetscErrorCode create(TS ts) {
  return guard([&] {
    ts->data = new Data;
    ts->ops->setup = set_up;
    ts->ops->step = step;
    ts->ops->destroy = destroy;
    ts->usessnes = PETSC_FALSE;
  });
}

}  // namespace

void register_central_difference() {
  check(TSRegister(central_difference_type, create));
}

void set_acceleration(TS ts, Acceleration acceleration, Vec a) {
  data_of(ts).acceleration = std::move(acceleration);
  data_of(ts).a = a;
}

}  // namespace stylet
