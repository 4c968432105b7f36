// Errors that a user can meet, each with the exit code of the program.
#pragma once

#include <stdexcept>
#include <string>

namespace stylet {

enum class ExitCode { done = 0, other = 1, bad_input = 2, numerical = 3, io = 4 };

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  [[nodiscard]] ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// A scene or a mesh that cannot be run; the message names file, line, key, value and what is
/// allowed.
class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : Error(ExitCode::bad_input, message) {}
};

/// A step that did not converge, an inverted element, an energy that grew without work.
class NumericalError : public Error {
 public:
  explicit NumericalError(const std::string& message) : Error(ExitCode::numerical, message) {}
};

/// A file that cannot be read or written, a full disk.
class IoError : public Error {
 public:
  explicit IoError(const std::string& message) : Error(ExitCode::io, message) {}
};

/// Asked to end by a signal; the exit code is 128 and its number, as a shell's.
class Stopped : public std::runtime_error {
 public:
  Stopped(int signal, const char* name)
      : std::runtime_error(std::string("stopped by signal ") + name), signal_(signal) {}
  [[nodiscard]] int code() const noexcept { return 128 + signal_; }

 private:
  int signal_;
};

}  // namespace stylet
