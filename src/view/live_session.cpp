#include "stylet/view/live_session.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/session.hpp"
#include "stylet/simulation/picture.hpp"
#include "stylet/view/publish.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace stylet {

namespace {

// More than this is not made up for after a pause of the machine: the needle would leap.
constexpr double most_behind = 0.25;          // s
constexpr double between_frames = 1.0 / 120;  // s
constexpr double stretch = 0.5;               // s, over which the pace is measured

}  // namespace

double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

LiveSession::LiveSession(MPI_Comm comm, LiveOptions options) {
  thread_ = std::thread([this, comm, options = std::move(options)]() mutable {
    try {
      use_in_this_thread();
      live(comm, std::move(options));
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
      news_.notify_all();
    }
  });
  std::unique_lock lock(mutex_);
  news_.wait(lock, [&] { return is_ready_ || failure_; });
  if (!failure_) return;
  lock.unlock();
  thread_.join();
  std::rethrow_exception(failure_);
}

LiveSession::~LiveSession() {
  stop();
}

void LiveSession::stop() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  news_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::string LiveSession::end() {
  stop();
  if (failure_) std::rethrow_exception(failure_);
  return last_words_;
}

void LiveSession::want(const std::variant<Aim, Push>& wanted) {
  const std::lock_guard lock(mutex_);
  wanted_ = wanted;
  has_wanted_ = true;
  wanted_at_ = clock_seconds();
}

void LiveSession::order(std::function<void(LiveRun&)> what) {
  {
    const std::lock_guard lock(mutex_);
    orders_.push_back(std::move(what));
  }
  news_.notify_all();
}

void LiveSession::pause(bool paused) {
  const std::lock_guard lock(mutex_);
  paused_ = paused;
}

void LiveSession::colour(Colouring colouring) {
  const std::lock_guard lock(mutex_);
  colouring_ = colouring;
}

bool LiveSession::take(Frame& frame) {
  const std::lock_guard lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
  if (!is_new_) return false;
  std::swap(frame, offered_);
  is_new_ = false;
  return true;
}

// Orders and what is wanted, before a step.
void LiveSession::obey(LiveRun& run) {
  std::vector<Order> orders;
  {
    const std::lock_guard lock(mutex_);
    orders.swap(orders_);
    if (has_wanted_) {
      run.want(wanted_);
      stamp_ = wanted_at_;
      has_wanted_ = false;
    }
  }
  for (const Order& order : orders) {
    const int epoch = run.epoch();
    try {
      order(run);
    } catch (const NumericalError& error) {
      error_ = error.what();
    }
    if (run.epoch() != epoch) error_.clear();
  }
}

// False after an error: time stands still until something is undone.
bool LiveSession::step(LiveRun& run) {
  const double start = clock_seconds();
  try {
    run.step();
  } catch (const NumericalError& error) {
    error_ = error.what();
    return false;
  } catch (const InputError& error) {
    error_ = error.what();
    return false;
  }
  const double took = clock_seconds() - start;
  stepping_ += took;
  all_stepping_ += took;
  pace_.all_longest = std::max(pace_.all_longest, took);
  simulated_ += run.last_step().h;
  sub_steps_ += run.last_step().sub_steps;
  ++steps_;
  return true;
}

void LiveSession::measure(double now) {
  const double passed = now - since_;
  pace_.all_busy = all_stepping_ / (now - start_);
  if (passed < stretch) return;
  pace_.real_time_factor = simulated_ / passed;
  pace_.busy = stepping_ / passed;
  pace_.sub_steps = steps_ > 0 ? static_cast<double>(sub_steps_) / static_cast<double>(steps_) : 0;
  since_ = now;
  simulated_ = stepping_ = 0;
  sub_steps_ = steps_ = 0;
}

void LiveSession::offer(const LiveRun& run) {
  Colouring colouring = Colouring::none;
  {
    const std::lock_guard lock(mutex_);
    colouring = colouring_;
  }
  publish(run, colouring, back_);
  back_.number = ++n_frames_;
  back_.error = error_;
  back_.hand_stamp = stamp_;
  back_.made_at = clock_seconds();
  back_.pace = pace_;
  back_.pace.step = run.step_length();
  const std::lock_guard lock(mutex_);
  std::swap(back_, offered_);
  is_new_ = true;
}

void LiveSession::live(MPI_Comm comm, LiveOptions options) {
  LiveRun run(comm, std::move(options));
  planned_ = run.planned();
  picture_ = picture_of(run.simulation().scene(), run.simulation().mesh());
  offer(run);
  {
    const std::lock_guard lock(mutex_);
    is_ready_ = true;
  }
  news_.notify_all();
  double last = start_ = since_ = clock_seconds();
  double behind = 0;
  double offered_at = last;
  for (;;) {
    bool stands = false;
    bool wanted = false;
    {
      std::unique_lock lock(mutex_);
      const double wait = std::clamp(run.step_length() - behind, 0.0, between_frames);
      news_.wait_for(lock, std::chrono::duration<double>(behind >= run.step_length() ? 0 : wait),
                     [&] { return ends_ || !orders_.empty(); });
      if (ends_) break;
      stands = paused_ || !error_.empty();
      wanted = !is_new_;
    }
    obey(run);
    const double now = clock_seconds();
    behind = stands ? 0 : behind + now - last;
    last = now;
    if (behind > most_behind) {
      pace_.lost += behind - most_behind;
      behind = most_behind;
    }
    const bool steps = !stands && error_.empty() && behind >= run.step_length();
    if (steps && step(run)) behind -= run.last_step().h;
    measure(clock_seconds());
    if (!wanted || clock_seconds() - offered_at < between_frames) continue;
    offer(run);
    offered_at = clock_seconds();
  }
  last_words_ = last_words(run);
}

}  // namespace stylet
