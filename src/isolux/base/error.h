#pragma once

#include <stdexcept>
#include <string>

namespace isolux {

/// Why a piece of work could not be done, for the person who asked: what it was about (a file, an
/// option), why, and a hint at the remedy. Printed as `isolux: error: WHAT: WHY; HINT`.
class Error : public std::runtime_error {
 public:
  Error(std::string what, std::string why, std::string hint)
      : std::runtime_error(what + ": " + why + "; " + hint),
        what_(std::move(what)),
        why_(std::move(why)),
        hint_(std::move(hint)) {}

  const std::string& what_it_is_about() const { return what_; }
  const std::string& why() const { return why_; }
  const std::string& hint() const { return hint_; }

 private:
  std::string what_;
  std::string why_;
  std::string hint_;
};

/// The work could not be done: unreadable or damaged input, no memory, cannot write. Exit status 1.
class WorkError : public Error {
  using Error::Error;
};

/// The command, or the scene file, was wrong. Exit status 2.
class UsageError : public Error {
  using Error::Error;
};

}  // namespace isolux
