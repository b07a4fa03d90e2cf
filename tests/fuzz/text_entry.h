// libFuzzer's entry points for readers of text: the fuzzer of each defines what it reads and which mutator knows its
// grammar. Included once in a program.
//
//   #define KN_FUZZ_READ(text) readRibInput(text)
//   #define KN_FUZZ_MUTATOR RibMutator
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t most);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kinora::fuzz::KN_FUZZ_READ((std::string_view{reinterpret_cast<const char*>(data), size}));
  return 0;
}

static size_t give(const std::string& s, uint8_t* out, size_t most) {
  const size_t n = s.size() < most ? s.size() : most;
  std::memcpy(out, s.data(), n);
  return n;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t most, unsigned seed) {
  if (seed % 16 == 0) return LLVMFuzzerMutate(data, size, most);
  const std::string text(reinterpret_cast<const char*>(data), size);
  return give(kinora::fuzz::KN_FUZZ_MUTATOR(seed).mutate(text, text, most), data, most);
}

extern "C" size_t LLVMFuzzerCustomCrossOver(const uint8_t* a, size_t aSize, const uint8_t* b, size_t bSize,
                                            uint8_t* out, size_t most, unsigned seed) {
  const std::string first(reinterpret_cast<const char*>(a), aSize), second(reinterpret_cast<const char*>(b), bSize);
  return give(kinora::fuzz::KN_FUZZ_MUTATOR(seed).mutate(first, second, most), out, most);
}
