#pragma once

#include <stdexcept>
#include <string>

namespace isolux {

/// Why a piece of work could not be done, for the person who asked: what it was about (a file, an
/// option), why, and a hint at the remedy. Printed as `isolux: error: WHAT: WHY; HINT`.
class Error : public std::runtime_error {
 public:
  Error(const std::string& what, const std::string& why, const std::string& hint)
      : std::runtime_error((what.empty() ? "''" : what) + ": " + why + "; " + hint) {}
  /// One that was told elsewhere: what() of it.
  explicit Error(const std::string& told) : std::runtime_error(told) {}
};

/// The work could not be done: unreadable or damaged input, no memory, cannot write. Exit status 1.
class WorkError : public Error {
 public:
  using Error::Error;
};

/// The command, or the scene file, was wrong. Exit status 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

}  // namespace isolux
