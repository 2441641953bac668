#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "isolux/bench/framing.h"
#include "isolux/bench/own_renderer.h"
#include "isolux/bench/peer_contest.h"
#include "isolux/bench/rivals.h"
#include "isolux/bench/scene_works.h"

namespace isolux {

class TemporaryPath;

/// As a request says it.
std::string words(Vec3 v);
std::string frame_request(const View& view);
std::string frame_request(const View& view);

/// Works on one subject in which isolux and its rivals take turns. All that is given is kept.
class Contest {
 public:
  // Enough for a median. A whole orbit, 360 turns, is for isolux and for peers of its speed alone.
  static constexpr int kFewTurns = 21;
  using ViewOfTurn = std::function<View(int turn)>;
  using TakesPart = std::function<bool(const Rival&)>;

  Contest(const std::string& subject, Rivals& rivals, const TemporaryPath& scratch,
          const ContestOptions& options)
      : subject_(subject), rivals_(rivals), scratch_(scratch), options_(options) {}

  const ContestOptions& options() const { return options_; }
  Rivals& rivals() const { return rivals_; }
  int few_turns() const { return std::min(options_.turns, kFewTurns); }

  /// Whole frames.
  Work view_work(const std::string& name, OwnRenderer& renderer, const ViewOfTurn& view_of,
                 int turns, const TakesPart& takes_part) const;
  /// Rays of no picture, as LooseRays counts them; the rivals' request is `rays` or `shadows`.
  Work ray_work(const std::string& name, const OwnRenderer& renderer, const std::vector<Ray>& rays,
                const std::optional<Vec3>& lamp, const TakesPart& takes_part) const;

  Measurement measured(const Work& work) const;

 private:
  std::string compared_picture(const std::string& work, const OwnRenderer& renderer,
                               Peer& peer) const;
  void keep_picture(const std::string& work, const std::string& who, const Picture& picture) const;

  std::string subject_;
  Rivals& rivals_;
  const TemporaryPath& scratch_;
  const ContestOptions& options_;
};

}  // namespace isolux
