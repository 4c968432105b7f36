#include "stylet/scene/overrides.hpp"
#include "stylet/study/campaign_plan.hpp"

#include "fuzz.hpp"

#include <algorithm>

namespace {

const char* const scene = R"(
mesh: {rectangle: {size: [8 cm, 6 cm], columns: 4, rows: 3}}
tissue: {plane: stress, regions: {lobe.left: {youngs_modulus: 60 kPa}}}
needles:
  - height: 3.2 cm
    motion: [{insert: {speed: 2 cm/s, position: 3.5 cm}}, {implant: {target: a}}]
targets: {a: [3.5 cm, 3.2 cm]}
time: {step: 5 ms}
)";

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stylet;
  fuzz::may_refuse([&] {
    const Campaign campaign = load_campaign("c", fuzz::text_of(data, size), {});
    // Large ones are only slow.
    constexpr int most = 30;
    const auto is_large = [](const auto& item) { return item.count > most; };
    if (campaign.samples > most || campaign.vary.size() > 5 || campaign.average.size() > 2 ||
        std::ranges::any_of(campaign.vary, is_large) ||
        std::ranges::any_of(campaign.average, is_large)) {
      return;
    }
    Node document = parse_yaml("s", scene);
    for (const auto& change : campaign.set) apply_override(document, "s", change);
    const CampaignPlan plan = plan_runs(campaign, document);
    std::size_t n_points = 0;
    for (const PlannedRun& run : plan.runs) {
      n_points += run.points.size();
      fuzz::require(run.outputs.size() == run.points.size(), "every point has outputs");
    }
    fuzz::require(n_points == plan.points.size() * plan.shifts.size(),
                  "every point is run once a shift");
    if (plan.runs.empty()) return;
    Node changed = document;
    for (const auto& change : plan.runs.front().overrides) apply_override(changed, "s", change);
  });
  return 0;
}
