#pragma once

#include <sys/types.h>

/// An X server without a screen (Xvfb) for this process alone, under a number that is free. It is
/// the value of DISPLAY while this lives.
class OwnDisplay {
 public:
  /// @throws std::runtime_error  where Xvfb is missing or does not start.
  OwnDisplay();
  ~OwnDisplay();
  OwnDisplay(const OwnDisplay&) = delete;
  OwnDisplay& operator=(const OwnDisplay&) = delete;

 private:
  pid_t server_ = -1;
};
