// A folder for the files of a fuzzed input, as long as the process runs.
#pragma once
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace kinora::fuzz {

struct ScratchFolder {
  std::string path;
  ScratchFolder() {
    const char* base = std::getenv("TMPDIR");
    path = (base ? std::string(base) : std::string("/tmp")) + "/kinora_fuzz_XXXXXX";
    if (!mkdtemp(path.data())) std::abort();
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

}  // namespace kinora::fuzz
