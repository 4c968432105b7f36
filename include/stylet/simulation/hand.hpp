// The hand that holds the needles: it says what comes next, from a scene's list or as it happens.
#pragma once

#include "stylet/mesh/mesh.hpp"
#include "stylet/needle/motion.hpp"
#include "stylet/scene/scene.hpp"
#include "stylet/simulation/settling.hpp"

#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

/// What comes next. step: time passes, whether a needle is in or not.
struct Wish {
  enum class Kind { step, enter, implant, change, done };
  Kind kind = Kind::step;
  const NeedleParameters* needle = nullptr;  ///< that enters; lent until it has
  std::string target = {};                   ///< of the seed
  std::string key = {};                      ///< of Simulation::change
  double value = 0;                          ///< SI
};

/// What a step led to.
struct StepOutcome {
  bool withdrawn = false;          ///< nothing of the needle is in the tissue
  bool conditions_change = false;  ///< loads or prescribed displacements did, in the step
  double largest_speed = 0;        ///< of the tissue (m/s); known where the hand awaits rest
};

/// A needle may enter at any time; the one before it stays where it is and lets go of the tissue.
class Hand {
 public:
  Hand() = default;
  Hand(const Hand&) = delete;
  Hand& operator=(const Hand&) = delete;
  virtual ~Hand() = default;

  [[nodiscard]] virtual Wish next() const = 0;
  /// The next step, at most `longest` (s), where that is the wish.
  [[nodiscard]] virtual NeedleStep step(double longest) = 0;
  /// The last step was shorter than the ones to come may be.
  virtual void choose_step_anew() {}
  [[nodiscard]] virtual Awaited awaits() const { return Awaited::nothing; }
  /// Grows where an action ends: a step of the clock ends there too.
  [[nodiscard]] virtual long long ended() const = 0;

  // What has become of the wish.

  /// The needle's tip stands at the skin, at this place along the axis (m); at_rest: its place in
  /// tissue that has not moved. Throws NumericalError where the hand cannot go on from there.
  virtual void entered(double skin, double at_rest) = 0;
  virtual void implanted() = 0;
  virtual void changed() {}
  /// Of the tip (m/s); not all hands have one.
  [[nodiscard]] virtual std::optional<double> speed_limit() const { return std::nullopt; }
  virtual void limit_speed(double /*most*/) {}
  /// The wish could not be fulfilled, and nothing has happened; its error is on the way.
  virtual void refused() {}
  /// Throws NumericalError where what is awaited will never be.
  virtual void stepped(const NeedleStep& step, const StepOutcome& outcome) = 0;
};

/// The needles of a scene, one after another.
class Schedule : public Hand {
 public:
  /// extent: of the tissue along the needle (m).
  Schedule(const Scene& scene, double extent);

  [[nodiscard]] Wish next() const override;
  [[nodiscard]] NeedleStep step(double longest) override { return motion_.next(longest); }
  void choose_step_anew() override { motion_.choose_step_anew(); }
  [[nodiscard]] Awaited awaits() const override { return motion_.awaits(); }
  [[nodiscard]] long long ended() const override { return ended_; }
  void entered(double skin, double at_rest) override;
  void implanted() override;
  void stepped(const NeedleStep& step, const StepOutcome& outcome) override;

 private:
  [[nodiscard]] bool comes_to_rest(const StepOutcome& outcome);

  std::vector<NeedleParameters> needles_;
  bool until_implanted_;
  double extent_;
  std::size_t n_entered_ = 0;
  bool last_seed_left_ = false;
  Motion motion_;  ///< of the present needle; without needles, of the clock
  Settling settling_;
  long long ended_ = 0;
};

/// Moved while the program runs: by a mouse, or by a rule of the caller. Orders are obeyed in turn,
/// before time goes on.
class LiveHand : public Hand {
 public:
  /// Its motion is not used. Without a name it gets needle1, needle2, ...
  void enter(NeedleParameters needle);
  /// Speed of the tip from now on (m/s): positive pushes, negative pulls, 0 holds.
  void move(double speed);
  void implant(std::string target = {});
  /// As Simulation::change, after the orders before it.
  void change(std::string key, double value);
  void finish();
  /// Of the speeds from now on, and of the present one (m/s); none: infinity.
  void limit_speed(double most) override;
  [[nodiscard]] std::optional<double> speed_limit() const override { return most_; }
  [[nodiscard]] double speed() const { return speed_; }
  [[nodiscard]] double tip() const { return tip_; }
  /// Where the simulation has gone back to an earlier state: the tip was there (m). Drops all orders; the
  /// needle is held.
  void hold_at(double tip);

  [[nodiscard]] Wish next() const override;
  [[nodiscard]] NeedleStep step(double longest) override;
  [[nodiscard]] long long ended() const override { return ended_; }
  void entered(double skin, double at_rest) override;
  void implanted() override;
  void changed() override;
  void refused() override;
  void stepped(const NeedleStep& step, const StepOutcome& outcome) override;

 protected:
  struct Ordered {
    Wish::Kind kind;
    NeedleParameters needle = {};
    std::string target = {};
    std::string key = {};
    double value = 0;
  };
  /// The order that is being obeyed.
  [[nodiscard]] const Ordered& order() const { return orders_.front(); }

 private:
  void obeyed();

  std::deque<Ordered> orders_;
  double speed_ = 0;  ///< m/s
  double most_ = std::numeric_limits<double>::infinity();
  double tip_ = 0;  ///< m
  long long ended_ = 0;
  int n_entered_ = 0;
};

/// Time that a scene takes (s), as far as it is known before.
[[nodiscard]] double expected_time(const Scene& scene, const Mesh& mesh);

}  // namespace stylet
