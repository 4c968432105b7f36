// A needle pushed into a block of tissue by a program that uses Stylet as a library: its own hand.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stylet/dynamics/state.hpp>
#include <stylet/petsc/session.hpp>
#include <stylet/scene/check.hpp>
#include <stylet/simulation/simulation.hpp>

stylet::Scene block() {
  stylet::Scene scene;
  scene.mesh.source =
      stylet::RectangleMesh{.width = 0.08, .height = 0.06, .columns = 24, .rows = 18};
  scene.tissue.regions = {
      {"tissue", {.youngs_modulus = 60e3, .poisson_ratio = 0.45, .density = 1000}}};
  scene.tissue.damping = stylet::RayleighDamping{.stiffness_factor = 0.05};
  for (const char* side : {"left", "top", "bottom"}) {
    scene.supports.push_back({side, stylet::SupportKind::fixed});
  }
  scene.probes = {{"ahead", {0.035, 0.032}}};
  scene.time.step = 0.01;
  scene.time.duration = 2;
  stylet::check(scene);
  return scene;
}

stylet::NeedleParameters needle() {
  stylet::NeedleParameters needle{.name = "needle", .height = 0.032};
  needle.cutting.cutting_force = 1.7;
  needle.cutting.tip_length = 6e-3;
  needle.friction = stylet::FrictionParameters{195, 130, 1e-3, 1.5e-3};
  return needle;
}

int main(int, char** argv) {
  const stylet::Session session(1, argv);
  return stylet::run_guarded([] {
    auto owned = std::make_unique<stylet::LiveHand>();
    stylet::LiveHand& hand = *owned;
    stylet::Simulation simulation(MPI_COMM_WORLD, block(), false, std::move(owned));
    hand.enter(needle());
    hand.move(0.02);
    do {
      simulation.step();
    } while (simulation.needle()->tip() - simulation.needle()->skin() < 0.04 - 1e-9);
    // The field: x and y of node 0, of node 1, ...
    const auto u = stylet::gather_all(simulation.state().u.get());
    double largest = 0;
    for (std::size_t i = 0; i < u.size(); i += 2)
      largest = std::max(largest, std::hypot(u[i], u[i + 1]));
    const auto ahead = simulation.body().world(simulation.probes())[0];
    std::printf("time %.17g\nahead_ux %.17g\nlargest %.17g\n", simulation.time(), ahead.x - 0.035,
                largest);
    return 0;
  });
}
