#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>
#include <string>

// The side of a peer in the conversation that bench/README.md describes: a line in, a line out.
// Standard library alone, so that peers can use it without linking isolux.

namespace isolux {

/// Answers one request from the words behind its name. Throws what goes out as "error WHY".
using RequestHandler = std::function<std::string(std::istringstream& words)>;

/// Says "ready NAME", then answers each line of standard input until it ends.
inline void answer_requests(const std::string& name,
                            const std::map<std::string, RequestHandler>& handlers) {
  std::cout << "ready " << name << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string request;
    words >> request;
    const auto found = handlers.find(request);
    std::string answer = "error there is no request '" + request + "'";
    if (found != handlers.end()) {
      words.exceptions(std::ios::failbit);
      try {
        answer = "ok " + found->second(words);
      } catch (const std::ios::failure&) {
        answer = "error a word is missing, or no number: " + line;
      } catch (const std::exception& error) {
        answer = std::string("error ") + error.what();
      }
    }
    std::cout << answer << std::endl;
  }
}

/// A number for a picture's bytes, to tell whether two are the same (FNV-1a, 32 bits).
inline std::uint32_t checksum_of(const std::uint8_t* bytes, std::size_t count) {
  std::uint32_t sum = 0x811c9dc5;
  for (std::size_t n = 0; n < count; ++n) sum = (sum ^ bytes[n]) * 0x01000193;
  return sum;
}

}  // namespace isolux
