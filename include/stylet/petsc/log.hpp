// Log stages and events by name; shown by -log_view and counted by tests.
#pragma once

#include "stylet/petsc/check.hpp"

#include <petsclog.h>

#include <string>

namespace stylet {

/// One event class a name; objects of this type are made where the event happens.
class LogEvent {
 public:
  explicit LogEvent(const char* name);
  [[nodiscard]] PetscLogEvent id() const { return id_; }

 private:
  PetscLogEvent id_ = 0;
};

/// Begins the event now and ends it at the end of the block.
class LogScope {
 public:
  explicit LogScope(const LogEvent& event) : id_(event.id()) {
    (void)PetscLogEventBegin(id_, nullptr, nullptr, nullptr, nullptr);
  }
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;
  ~LogScope() { (void)PetscLogEventEnd(id_, nullptr, nullptr, nullptr, nullptr); }

 private:
  PetscLogEvent id_;
};

/// How often an event began on this rank since the start (0 if the name was never registered).
/// Needs PetscLogDefaultBegin.
[[nodiscard]] int event_count(const std::string& name);

}  // namespace stylet
