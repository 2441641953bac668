#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>

#include "isolux/base/error.h"
#include "isolux/cli/command.h"
#include "isolux/cli/loaded_scene.h"
#include "isolux/cli/open_browser.h"
#include "isolux/cli/terminal.h"
#include "isolux/scene/option_value.h"
#include "isolux/server/access.h"
#include "isolux/server/door.h"
#include "isolux/server/page_files.h"

namespace isolux {
namespace {

DoorOptions door_options(const Command& command, const Arguments& arguments) {
  DoorOptions options;
  if (arguments.has("host")) options.host = arguments.at("host");
  if (arguments.has("port")) {
    const Option& port = *find_option(command.options, "port");
    options.port = value_from_text(port, arguments.at("port"), "--port").get<int>();
  }
  options.token = user_token();
  return options;
}

// How to see the page from another machine, for those who came by ssh.
void tell_about_tunnel(int port) {
  const char* connection = std::getenv("SSH_CONNECTION");
  if (!connection) return;
  const std::string at = std::to_string(port);
  std::cerr << "isolux: from your own machine: ssh -N -L " << at << ":127.0.0.1:" << at
            << " THIS-MACHINE, then open the URL there\n";
}

}  // namespace

int run_view(const Command& command, const Arguments& arguments) {
  if (!has_page()) {
    throw WorkError("view", "this program was built without its page, for want of Node.js or npm",
                    "install nodejs and npm, remove " ISOLUX_PAGE_FILES " and build again");
  }
  LoadedScene loaded = load_scene(arguments);
  const DoorOptions options = door_options(command, arguments);
  Viewer viewer(ISOLUX_VERSION, loaded.document, std::move(loaded.inputs));
  Door door(options, viewer);
  const bool is_private = is_loopback(options.host);
  if (!is_private) {
    warn("the viewer can be reached from the network at " + options.host +
         ", without encryption; whoever sees the URL can see the scans");
  }
  const std::string url = "http://" + (is_private ? options.host : std::string("127.0.0.1")) + ":" +
                          std::to_string(door.port()) + "/#" + options.token;
  std::cout << url << std::endl;
  if (is_private) tell_about_tunnel(door.port());
  if (!arguments.has("no-open")) open_browser(url);
  door.run();
  viewer.finish();
  return 0;
}

}  // namespace isolux
