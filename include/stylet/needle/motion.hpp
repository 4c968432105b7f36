// A needle's list of actions as steps of time.
#pragma once

#include "stylet/base/archive.hpp"
#include "stylet/needle/parameters.hpp"

#include <optional>
#include <vector>

namespace stylet {

/// One step of the needle: its tip goes from `from` to `to` (coordinates along the axis, m).
struct NeedleStep {
  double h = 0;  ///< s
  double from = 0;
  double to = 0;
  /// m/s, positive while inserting
  [[nodiscard]] double speed() const { return h > 0 ? (to - from) / h : 0; }
};

/// What an action without an end of its own waits for.
enum class Awaited { nothing, withdrawal, rest };

/// The present action is never over: the next one begins at once.
class Motion {
 public:
  explicit Motion(std::vector<Action> actions) : actions_(std::move(actions)) {}

  /// The tip stands at the skin; along_sign turns positions of the scene into along coordinates.
  void enter(double skin_along, double along_sign);
  [[nodiscard]] bool finished() const { return at_ == actions_.size(); }
  [[nodiscard]] const Action& action() const { return actions_[at_]; }
  [[nodiscard]] std::size_t index() const { return at_; }
  [[nodiscard]] double tip() const { return tip_; }
  [[nodiscard]] double skin() const { return skin_; }
  [[nodiscard]] Awaited awaits() const;
  /// True if another implant comes, the present action apart.
  [[nodiscard]] bool will_implant() const;

  /// The next step, at most `longest`. Steps of one action have equal lengths, so that the step's
  /// operator can be used again. Not for implant.
  [[nodiscard]] NeedleStep next(double longest);
  /// The step was taken. awaited: what the action waits for has happened.
  void taken(const NeedleStep& step, bool awaited = false);
  /// A step that was shorter than allowed for once does not shorten those that follow.
  void choose_step_anew() { h_ = 0; }
  /// The seed of the present action was left.
  void implanted();

  /// The only action, which lasted so long (s), lasts longer or ends sooner than it did.
  void change_end(double before);

  /// How far it is; the actions are given.
  void archive(Archive& archive);

 private:
  [[nodiscard]] std::optional<double> target() const;
  [[nodiscard]] bool is_over(bool awaited) const;
  void go_on(bool awaited);

  std::vector<Action> actions_;
  std::size_t at_ = 0;
  double along_sign_ = 1;
  double skin_ = 0;
  double tip_ = 0;
  double elapsed_ = 0;  ///< in this action
  double h_ = 0;        ///< of this action's steps; 0 before the first
  long long left_ = 0;  ///< steps of length h_ left; 0 if the end is not known
};

}  // namespace stylet
