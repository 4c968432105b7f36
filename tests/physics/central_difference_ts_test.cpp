// The private structure of PETSc's TS is in this release as central_difference_ts.cpp takes it to be.
#include "stylet/dynamics/central_difference_ts.hpp"

#include "stylet/petsc/check.hpp"
#include "stylet/petsc/entries.hpp"
#include "stylet/petsc/owned.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace stylet {
namespace {

class CentralDifferenceTs : public testing::Test {
 protected:
  CentralDifferenceTs() {
    register_central_difference();
    check(TSCreate(PETSC_COMM_SELF, ts.put()));
    check(TSSetType(ts.get(), central_difference_type));
    for (OwnedVec* vec : {&u, &v}) {
      check(VecCreateSeq(PETSC_COMM_SELF, 3, vec->put()));
      check(VecSet(vec->get(), 0));
    }
    check(TSSetMaxSteps(ts.get(), 10));
    check(TSSetExactFinalTime(ts.get(), TS_EXACTFINALTIME_STEPOVER));
    check(TS2SetSolution(ts.get(), u.get(), v.get()));
    check(TSSetTime(ts.get(), 1.5));
    check(TSSetTimeStep(ts.get(), 0.25));
  }

  OwnedVec u;
  OwnedVec v;
  OwnedTs ts;
};

TEST_F(CentralDifferenceTs, StepsTheVectorsItWasGivenByTheStepItWasGiven) {
  double stepped = 0;
  set_step(ts.get(), [&](double h, Vec u1, Vec v1) {
    stepped = h;
    EXPECT_EQ(u1, u.get());
    EXPECT_EQ(v1, v.get());
    check(VecSet(u1, 3));
    check(VecSet(v1, 4));
  });
  check(TSStep(ts.get()));
  check(TSStep(ts.get()));
  EXPECT_EQ(stepped, 0.25);
  EXPECT_EQ(Values(u.get())[2], 3);
  EXPECT_EQ(Values(v.get())[0], 4);
  PetscReal time = 0;
  check(TSGetTime(ts.get(), &time));
  EXPECT_EQ(time, 2);  // all are sums of powers of two
  PetscInt steps = 0;
  check(TSGetStepNumber(ts.get(), &steps));
  EXPECT_EQ(steps, 2);
}

TEST_F(CentralDifferenceTs, PassesOnWhatAStepThrows) {
  set_step(ts.get(), [](double, Vec, Vec) { throw std::out_of_range("no step"); });
  EXPECT_THROW(check(TSStep(ts.get())), std::out_of_range);
}

}  // namespace
}  // namespace stylet
