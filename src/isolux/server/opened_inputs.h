#pragma once

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "isolux/io/provenance.h"
#include "isolux/io/reader.h"
#include "isolux/scene/scene.h"

namespace isolux {

/// The inputs that pages may look at: those of the command line, and those that were dropped on a
/// page. A page names them by these names; nothing it says is ever taken for a path. Any thread may
/// call.
class OpenedInputs {
 public:
  /// @param how  the scene options by which the input was read ("dims", "spacing", ...), as a
  ///             document's keys.
  /// @param dropped  a file that came over the network: its path is of no use to anyone, and only
  ///             the last four that came stay open.
  /// @return the name under which it is open; another than its own where that was taken.
  std::string add(ReadResult input, const nlohmann::json& how, bool dropped);

  /// One for each input that the document names.
  /// @throws WorkError   where one is not open.
  /// @throws UsageError  where the document wants it read another way than it was.
  std::vector<SceneInput> inputs_of(const nlohmann::json& document) const;

  /// Checksums of the same inputs, worked out now or, of dropped ones, when they came.
  std::vector<InputChecksums> checksums_of(const nlohmann::json& document) const;

  /// What pages are told: mesh_report, or input_report with the histogram and the placement.
  nlohmann::json reports() const;

 private:
  struct Input {
    ReadResult read;
    nlohmann::json how;
    bool dropped;
    InputChecksums checksums;  ///< of a dropped one
    nlohmann::json report;
  };

  const Input& named(const std::string& name, const nlohmann::json& document) const;

  mutable std::mutex mutex_;
  std::vector<Input> inputs_;
};

/// The keys of a document that say how inputs are read.
nlohmann::json reading_keys(const nlohmann::json& document);

}  // namespace isolux
