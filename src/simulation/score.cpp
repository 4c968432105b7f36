#include "stylet/simulation/score.hpp"

namespace stylet {

Score score_of(const Simulation& simulation) {
  Score score;
  score.time = simulation.time();
  return score;
}

std::string text_of(const Score& /*score*/) {
  return {};
}

nlohmann::ordered_json json_of(const Score& /*score*/) {
  return {};
}

}  // namespace stylet
