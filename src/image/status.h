// The answer of everything that can fail on a file or on sizes that a file or a user gave: ok, or a code and a
// sentence. Returned by image/ and film/ so that no exception leaves them; the caller turns it into a Diagnostics
// message and an exit code. It carries no position: the caller knows which request named the file.
#pragma once
#include <string>
#include <utility>

namespace kinora::image {

struct [[nodiscard]] Status {
  std::string code;  // "" when all is well, else stable and in capitals: "IMAGE-OPEN", "FILM-SHARD-HASH" ...
  std::string what;  // one sentence naming the file or object
  bool ok() const { return code.empty(); }
  static Status fail(std::string code, std::string what) { return {std::move(code), std::move(what)}; }
};

}  // namespace kinora::image
