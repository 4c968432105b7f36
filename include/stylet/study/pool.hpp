// Many runs on groups of ranks.
#pragma once

#include <mpi.h>

#include <functional>
#include <optional>
#include <span>
#include <string>

namespace stylet {

/// Told by a running task how far it is, 0 to 1, between its steps.
using Poll = std::function<void(double)>;

/// Groups of `ranks_per_run` ranks take tasks as they become free. The first rank of all works too: it
/// hands out tasks between its own steps, so that no core is lost to a master.
class Pool {
 public:
  /// Collective. Throws InputError if there are fewer ranks than a run takes. Ranks that fill no
  /// group stay idle.
  Pool(MPI_Comm comm, int ranks_per_run);
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  ~Pool();

  [[nodiscard]] int n_groups() const { return n_groups_; }

  /// Collective over `group`; what its first rank returns is the result. None: a signal has stopped it.
  using Task =
      std::function<std::optional<std::string>(int task, MPI_Comm group, const Poll& poll)>;
  /// On rank 0, in the order in which results come.
  using Done = std::function<void(int task, const std::string& result)>;

  /// Collective. `tasks` are the numbers handed on to `task`; `poll` is called on rank 0 only, while
  /// it works on a task of its own. What task, done or poll throw ends the job (run_guarded). False if a
  /// signal has stopped a task, or rank 0 before it had handed out all: those that go on are waited for.
  [[nodiscard]] bool run(std::span<const int> tasks,
                         const Task& task,
                         const Done& done,
                         const Poll& poll);

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  MPI_Comm group_ = MPI_COMM_NULL;  ///< null on idle ranks
  int n_groups_ = 0;
};

}  // namespace stylet
