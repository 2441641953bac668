#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "isolux/server/client.h"
#include "isolux/server/long_work.h"
#include "isolux/server/opened_inputs.h"
#include "isolux/server/work_queue.h"

namespace isolux {

/// What a page has sent, to be opened.
struct DroppedFile {
  std::string path;        ///< where it lies now
  std::string name;        ///< what the page calls it
  bool is_packed = false;  ///< several files in a tar, as the page packs them
};

/// What `isolux view` serves, apart from how bytes travel: opened inputs, a client for each page,
/// and the threads that draw for them in turn.
class Viewer {
 public:
  /// @param document  the scene that a page starts with; its inputs are those of `inputs`.
  Viewer(std::string version, const nlohmann::json& document, std::vector<ReadResult> inputs);

  /// A page has come; it is told what is open and what to start with.
  std::shared_ptr<Client> connect(const std::shared_ptr<Outlet>& outlet);

  /// The bytes of a PNG or EXR file, the same as `isolux render` writes. Takes its time.
  /// @param request  { "scene", "format": "png" | "exr" }, not yet checked.
  std::string saved_picture(const nlohmann::json& request, const ProgressListener& listener) const;

  /// Reads what a page has sent, and opens it under its name. Takes its time.
  /// @return JSON: a scene to begin with, its bounds, and all that is open.
  std::string open_dropped(const DroppedFile& file, const ProgressListener& listener);

  /// Ends all work, so that no outlet is called any more.
  void finish();

  LongWork& long_work() { return long_work_; }

 private:
  std::string version_;
  nlohmann::json document_, bounds_;
  OpenedInputs inputs_;
  WorkQueue drawing_;
  LongWork long_work_;
};

}  // namespace isolux
