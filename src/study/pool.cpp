#include "stylet/study/pool.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/status_file.hpp"
#include "stylet/petsc/session.hpp"

#include <cstddef>
#include <optional>
#include <string>

namespace stylet {

namespace {

constexpr int result_tag = 1;
constexpr int task_tag = 2;
constexpr int no_task = -1;
constexpr const char* stopped_text = "stopped";  // a result begins with its task's number

/// Rank 0's side: which task is next, and who has been told that there is none.
class Counter {
 public:
  Counter(MPI_Comm comm, std::span<const int> tasks, const Pool::Done& done)
      : comm_(comm), tasks_(tasks), done_(done) {}

  int next() {
    if (at_ == tasks_.size()) return no_task;
    if (StatusFile::signal() != 0) stop();
    return stopped_ ? no_task : tasks_[at_++];
  }

  void stop() { stopped_ = true; }
  [[nodiscard]] bool stopped() const { return stopped_; }

  void serve_waiting() {
    int waiting = 1;
    while (waiting != 0) {
      MPI_Status status;
      MPI_Iprobe(MPI_ANY_SOURCE, result_tag, comm_, &waiting, &status);
      if (waiting != 0) serve(status);
    }
  }

  void serve_rest(int n_others) {
    while (dismissed_ < n_others) {
      MPI_Status status;
      MPI_Probe(MPI_ANY_SOURCE, result_tag, comm_, &status);
      serve(status);
    }
  }

 private:
  void serve(const MPI_Status& status) {
    int size = 0;
    MPI_Get_count(&status, MPI_CHAR, &size);
    std::string text(static_cast<std::size_t>(size), '\0');
    MPI_Recv(text.data(), size, MPI_CHAR, status.MPI_SOURCE, result_tag, comm_, MPI_STATUS_IGNORE);
    if (text == stopped_text) stop();
    const int given = next();
    if (given == no_task) ++dismissed_;
    MPI_Send(&given, 1, MPI_INT, status.MPI_SOURCE, task_tag, comm_);
    const auto end = text.find(' ');
    if (end != std::string::npos) done_(std::stoi(text.substr(0, end)), text.substr(end + 1));
  }

  MPI_Comm comm_;
  std::span<const int> tasks_;
  const Pool::Done& done_;
  std::size_t at_ = 0;
  int dismissed_ = 0;
  bool stopped_ = false;
};

}  // namespace

Pool::Pool(MPI_Comm comm, int ranks_per_run) {
  const int size = size_of(comm);
  if (ranks_per_run < 1 || ranks_per_run > size) {
    throw InputError("--ranks-per-run " + std::to_string(ranks_per_run) + ": allowed: 1 to " +
                     std::to_string(size) + ", the number of ranks (mpirun -n)");
  }
  MPI_Comm_dup(comm, &comm_);
  n_groups_ = size / ranks_per_run;
  const int rank = rank_of(comm);
  const bool idle = rank >= n_groups_ * ranks_per_run;
  MPI_Comm_split(comm, idle ? MPI_UNDEFINED : rank / ranks_per_run, rank, &group_);
}

Pool::~Pool() {
  if (group_ != MPI_COMM_NULL) MPI_Comm_free(&group_);
  if (comm_ != MPI_COMM_NULL) MPI_Comm_free(&comm_);
}

bool Pool::run(std::span<const int> tasks, const Task& task, const Done& done, const Poll& poll) {
  const bool first = rank_of(comm_) == 0;
  Counter counter(comm_, tasks, done);
  const auto between_steps = [&](double fraction) {
    if (!first) return;
    counter.serve_waiting();
    poll(fraction);
  };
  const bool leads = group_ != MPI_COMM_NULL && rank_of(group_) == 0;
  std::string result;
  while (group_ != MPI_COMM_NULL) {
    int given = no_task;
    if (first) {
      counter.serve_waiting();
      given = counter.next();
    } else if (leads) {
      MPI_Send(result.data(), static_cast<int>(result.size()), MPI_CHAR, 0, result_tag, comm_);
      MPI_Recv(&given, 1, MPI_INT, 0, task_tag, comm_, MPI_STATUS_IGNORE);
    }
    MPI_Bcast(&given, 1, MPI_INT, 0, group_);
    if (given == no_task) break;
    const std::optional<std::string> text = task(given, group_, between_steps);
    if (first && text) done(given, *text);
    if (first && !text) counter.stop();
    result = text ? std::to_string(given) + " " + *text : stopped_text;
  }
  if (first) counter.serve_rest(n_groups_ - 1);
  int finished = counter.stopped() ? 0 : 1;
  MPI_Bcast(&finished, 1, MPI_INT, 0, comm_);
  return finished == 1;
}

}  // namespace stylet
