#pragma once

#include <string>

#include "isolux/base/progress.h"
#include "isolux/cli/command.h"
#include "isolux/io/reader.h"

namespace isolux {

/// A progress bar on standard error, where that is a terminal or --progress is given; else nobody.
ProgressListener progress_bar(const Arguments& arguments);

/// "isolux: ..." on standard error.
void tell(const std::string& text);

/// "isolux: warning: ..." on standard error.
void warn(const std::string& text);

/// "isolux: NAME: NOTE" on standard error, for each decision that reading an input took.
void tell_notes(const ReadResult& input);

}  // namespace isolux
