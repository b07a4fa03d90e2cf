// libFuzzer's entry points for pictures and textures; built and run by tests/fuzz/run. The image libraries are not
// instrumented: what they say about a file counts as coverage instead.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>

#include "fuzz/image_input.h"
#include "fuzz/image_mutator.h"

__attribute__((section("__libfuzzer_extra_counters"))) static uint8_t outcomes[8192];

// OpenImageIO 2.4's PNG reader leaves a read that failed by longjmp, past the string that it holds: some thirty bytes
// for each cut file, not ours to mend.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:OpenImageIO_v2_4::ImageInput::geterror\n"; }

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  if (const char* folder = std::getenv("KINORA_FUZZ_SEEDS"))
    for (const auto& [name, bytes] : kinora::fuzz::smallImages())
      std::ofstream(std::string(folder) + "/" + name, std::ios::binary)
          .write(bytes.data(), std::streamsize(bytes.size()));
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  auto outcome = kinora::fuzz::loadImageInput({reinterpret_cast<const char*>(data), size});
  for (char& c : outcome.words)
    if (c >= '0' && c <= '9') c = '0';
  outcomes[std::hash<std::string>()(outcome.words) % sizeof outcomes] = 1;
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const std::string out = kinora::fuzz::ImageMutator(seed).mutate(bytes, {}, most);
  std::memcpy(data, out.data(), out.size());
  return out.size();
}

extern "C" size_t LLVMFuzzerCustomCrossOver(const uint8_t* a, size_t aSize, const uint8_t* b, size_t bSize,
                                            uint8_t* to, size_t most, unsigned seed) {
  const std::string first(reinterpret_cast<const char*>(a), aSize), second(reinterpret_cast<const char*>(b), bSize);
  const std::string out = kinora::fuzz::ImageMutator(seed).mutate(first, second, most);
  std::memcpy(to, out.data(), out.size());
  return out.size();
}
