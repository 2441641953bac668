#include "isolux/bench/peer.h"

#include <gtest/gtest.h>

#include "isolux/base/error.h"
#include "temporary_folder.h"

namespace isolux {
namespace {

class PeerProcess : public TemporaryFolder {
 protected:
  std::string log() const { return folder_ / "log"; }
  std::vector<std::string> shell(const std::string& script) const {
    return {"/bin/sh", "-c", script};
  }
  // What asking for `request` throws; empty: nothing.
  std::string fault_of(const std::string& script, const std::string& request) const {
    try {
      Peer peer("Nobody", shell(script), log());
      peer.ask_ms(request);
      return {};
    } catch (const WorkError& error) {
      return error.what();
    }
  }
};

TEST_F(PeerProcess, AnswersTheNumbersBehindOkAndHasTheNameItGaveItself) {
  Peer peer("Nobody", shell("echo ready Somebody 1.2; while read a b; do echo ok $b 7.5; done"),
            log());
  EXPECT_EQ(peer.name(), "Somebody 1.2");
  EXPECT_EQ(peer.ask("frame 3"), (std::vector{3, 7.5}));
  EXPECT_EQ(peer.ask_ms("frame 0.25"), 0.25);
}

TEST_F(PeerProcess, LinesThatComeTogetherAreToldApart) {
  Peer peer("Nobody", shell("printf 'ready X\\nok 1\\nok 2\\n'; cat > /dev/null"), log());
  EXPECT_EQ(peer.ask_ms("a"), 1);
  EXPECT_EQ(peer.ask_ms("b"), 2);
}

TEST_F(PeerProcess, OneThatEndsIsAnErrorInTheWordsOfItsLog) {
  const std::string fault = fault_of("echo first >&2; echo no screen >&2", "frame");
  EXPECT_NE(fault.find("Nobody: it has ended (no screen)"), std::string::npos) << fault;
  EXPECT_NE(fault_of("echo ready X; exit 3", "frame"), "");
}

TEST_F(PeerProcess, AnErrorAStrangerAndAMissingNumberAreErrors) {
  for (const char* answer : {"error no volume", "ok", "ok many", "5"}) {
    const std::string fault =
        fault_of(std::string("echo ready X; read a; echo '") + answer + "'", "frame");
    EXPECT_NE(fault.find(answer), std::string::npos) << fault;
  }
  EXPECT_NE(fault_of("echo hello", "frame").find("it began with 'hello'"), std::string::npos);
}

TEST_F(PeerProcess, AProgramThatIsNotThereIsAnError) {
  EXPECT_THROW(Peer("Nobody", {folder_ / "none"}, log()), WorkError);
}

}  // namespace
}  // namespace isolux
