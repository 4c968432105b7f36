// Forces and energies over time, for plots: all of a procedure in bounded memory.
#pragma once

#include "stylet/view/frame.hpp"

#include <cstddef>
#include <vector>

namespace stylet {

/// Keeps every n-th step; when the room is full every second one goes and n doubles.
class Trace {
 public:
  void add(const Sample& sample) {
    if (skipped_++ % every_ != 0) return;
    samples_.push_back(sample);
    if (samples_.size() < most) return;
    for (std::size_t i = 0; 2 * i < samples_.size(); ++i) samples_[i] = samples_[2 * i];
    samples_.resize(samples_.size() / 2);
    every_ *= 2;
  }
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }

 private:
  static constexpr std::size_t most = 2048;

  std::vector<Sample> samples_;
  std::size_t every_ = 1;
  std::size_t skipped_ = 0;
};

}  // namespace stylet
