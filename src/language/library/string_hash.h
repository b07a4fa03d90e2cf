// The 64-bit string hash of the language's hash(string): FarmHash by Geoff Pike (Google, published 2014), the "xo"
// variant, written from the published algorithm. hash("") is 0 by the language's rule.
#pragma once
#include <cstdint>
#include <string_view>

namespace kinora::language {

uint64_t farmHash64(std::string_view s);
inline int32_t hashString(std::string_view s) { return s.empty() ? 0 : int32_t(uint32_t(farmHash64(s))); }

}  // namespace kinora::language
