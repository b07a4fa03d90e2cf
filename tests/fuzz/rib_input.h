// One fuzzing input and how it is read. An input is the bytes of a RIB file; lines "##file NAME" cut off further
// files that stand beside it, so that archives, gzip and zip members are attacked too. Used by the fuzzer and its
// short test.
#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kinora::fuzz {

struct RibInput {
  std::string main;
  std::vector<std::pair<std::string, std::string>> files;  // name, bytes
};
RibInput splitInput(std::string_view bytes);
std::string joinInput(const RibInput& in);

// Folder for the files of inputs, made once for the process and removed at its end.
const std::string& inputFolder();
// Reads the input, writes each world as RIB and reads that again. Returns the number of messages.
size_t readRibInput(std::string_view bytes);

std::string gzipped(std::string_view bytes);
std::string zipped(const std::string& member, std::string_view bytes, bool deflated);
bool gunzipped(std::string_view bytes, std::string& out, size_t limit);

}  // namespace kinora::fuzz
