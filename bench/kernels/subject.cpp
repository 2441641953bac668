#include "subject.h"

#include <map>

#include "isolux/volume/phantom.h"

isolux::OwnRenderer& head_of(int size) {
  static std::map<int, isolux::OwnRenderer> heads;
  const auto found = heads.find(size);
  if (found != heads.end()) return found->second;
  const auto volume = std::make_shared<const isolux::Volume>(isolux::head_phantom(size));
  isolux::OwnRenderer& head =
      heads.emplace(size, isolux::bench_scene(volume, 300, 1024, 1024)).first->second;
  head.prepare();
  head.frame();
  return head;
}
