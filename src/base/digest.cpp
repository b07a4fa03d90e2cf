#include "base/digest.h"

#include <cstdio>
#include <cstring>

namespace kinora {

std::string Digest::str() const {
  char text[33];
  std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(high),
                static_cast<unsigned long long>(low));
  return text;
}

void Hasher::bytes(const void* data, size_t size) {
  const char* at = static_cast<const char*>(data);
  uint64_t w[2];
  for (size_t left = size; left >= sizeof w; left -= sizeof w, at += sizeof w) {
    std::memcpy(w, at, sizeof w);
    step(w[0], w[1]);
  }
  if (const size_t rest = size % sizeof w) {
    w[0] = w[1] = 0;
    std::memcpy(w, at, rest);
    step(w[0], w[1]);
  }
  step(size, ~kFrame);
}

Digest Hasher::result() const {
  // each half of the result depends on both lanes
  const uint64_t a = fold(high_ ^ 0xa0761d6478bd642fu, low_ ^ 0xe7037ed1a0b428dbu);
  const uint64_t b = fold(low_ ^ 0x8ebc6af09c88c6e3u, (high_ << 32 | high_ >> 32) ^ 0x589965cc75374cc3u);
  return {a ^ high_, b ^ low_};
}

Digest digestOf(std::string_view bytes) {
  Hasher h;
  h.text(bytes);
  return h.result();
}

}  // namespace kinora
