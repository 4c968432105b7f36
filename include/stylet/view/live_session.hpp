// The procedure in a thread of its own, in step with the clock. All that knows PETSc happens there;
// the caller gives orders and reads copies.
#pragma once

#include "stylet/image/picture.hpp"
#include "stylet/view/frame.hpp"
#include "stylet/view/live_run.hpp"

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

namespace stylet {

/// Seconds of a clock that never goes back.
[[nodiscard]] double clock_seconds();

class LiveSession {
 public:
  /// Makes the procedure, in its thread. MPI must allow calls from one thread at a time; the caller makes
  /// none until the session has ended. Throws what the procedure throws.
  LiveSession(MPI_Comm comm, LiveOptions options);
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;
  ~LiveSession();

  /// From the next step on.
  void want(const std::variant<Aim, Push>& wanted);
  /// Obeyed in turn, before the next step.
  void order(std::function<void(LiveRun&)> what);
  void pause(bool paused);
  void colour(Colouring colouring);
  /// Of the tissue before anything moved.
  [[nodiscard]] const Picture& picture() const { return picture_; }
  [[nodiscard]] const std::vector<PlannedWay>& planned() const { return planned_; }
  /// Ends the procedure. What there is to say of it.
  [[nodiscard]] std::string end();
  /// True if there is a newer frame than the last one taken.
  bool take(Frame& frame);

 private:
  using Order = std::function<void(LiveRun&)>;

  void live(MPI_Comm comm, LiveOptions options);
  void stop();
  void obey(LiveRun& run);
  bool step(LiveRun& run);
  void measure(double now);
  void offer(const LiveRun& run);

  // Made before anyone asks, or after the thread has ended.
  Picture picture_;
  std::vector<PlannedWay> planned_;
  std::string last_words_;

  // Shared, under the mutex.
  std::mutex mutex_;
  std::condition_variable news_;
  std::variant<Aim, Push> wanted_;
  bool has_wanted_ = false;
  double wanted_at_ = 0;  ///< s
  std::vector<Order> orders_;
  bool paused_ = false;
  bool ends_ = false;
  Colouring colouring_ = Colouring::none;
  Frame offered_;
  bool is_new_ = false;
  bool is_ready_ = false;
  std::exception_ptr failure_;

  // Of the thread alone.
  Frame back_;
  std::string error_;
  double stamp_ = 0;
  Pace pace_;
  double start_ = 0;         ///< s
  double all_stepping_ = 0;  ///< s, since then
  double since_ = 0;         ///< start of the present stretch of measurement (s)
  double simulated_ = 0;     ///< in it (s)
  double stepping_ = 0;      ///< s
  long long sub_steps_ = 0;
  long steps_ = 0;
  std::uint64_t n_frames_ = 0;

  std::thread thread_;
};

}  // namespace stylet
