#pragma once

#include <functional>
#include <string>
#include <vector>

namespace isolux {

/// Something that can do one turn of a work and says how many ms it took. What is not to be timed
/// is done outside the clock.
struct Contestant {
  std::string name;
  std::function<double(int turn)> ms;
  /// Takes part in every n-th turn alone, where it is slow and many turns are asked for.
  int every = 1;
  std::string note = {};
};

/// One thing to time, by isolux and by what it is compared with.
struct Work {
  std::string name;
  int turns = 1;
  std::function<double(int turn)> ms;  ///< isolux's own turn
  std::vector<Contestant> others = {};
  /// How many rays one turn handles; where given, a rate is shown in place of the time.
  double rays = 0;
  std::string note = {};  ///< what a reader should know, such as the share of pixels hit
};

struct Comparison {
  std::string name;
  std::string note;
  std::vector<double> ms;
  /// For each of its turns: its time over that of isolux's turn just before.
  std::vector<double> ratios;
};

struct Measurement {
  std::string work;
  std::string note;
  double rays = 0;
  std::vector<double> ms;
  std::vector<Comparison> comparisons;
  double load = -1;  ///< load average when the work ended
};

/// Does all turns, interleaved: isolux, the first other, isolux, the second other, ... and on with
/// the next turn, so that whatever slows the machine for a while slows both sides of a pair. The
/// turn after the last is done first and not counted, to warm up.
Measurement measure(const Work& work);

}  // namespace isolux
