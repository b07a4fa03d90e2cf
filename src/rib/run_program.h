// A program that a scene names (Procedural "RunProgram"), run for the RIB that it prints. Called by the interpreter, and
// only where the user allowed it.
#pragma once
#include <atomic>
#include <optional>
#include <string>
#include <vector>

namespace kinora::rib {

struct ProgramLimits {
  double seconds = 60;
  size_t bytes = size_t(1) << 30;
  const std::atomic<bool>* stop = nullptr;  // set: it is ended as if its time was over
};

// What it printed up to its end or to a byte 255, with which it says that it has answered. It is run as it is named, or
// found along PATH, without a shell; `request` is its standard input. Nothing and a reason when it cannot be run, fails
// without an answer, takes too long or prints too much: it is ended then.
std::optional<std::string> runProgram(const std::vector<std::string>& words, const std::string& request,
                                      const ProgramLimits& limits, std::string& why);

}  // namespace kinora::rib
