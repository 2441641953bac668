#pragma once

#include <string>

namespace isolux {

/// Opens the URL in the user's browser, where there is a display; says nothing where that fails.
/// The URL holds a secret, which a command line would show to every user of the machine, so the
/// browser is given a file that only this user can read and that leads on to it.
void open_browser(const std::string& url);

}  // namespace isolux
