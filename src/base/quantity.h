// Sizes and times as people write them, on the command line and in scenes.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace kinora {

// "4G", "512M", "1.5G", "100k" (powers of 1024, with or without a B or iB) or bytes; 0 when it is none of these.
uint64_t parseSize(std::string_view text);
// Seconds of "90s", "5m", "2h", "1.5h", "1d" or seconds; nothing when it is none of these, negative or beyond 1e9.
std::optional<double> parseTime(std::string_view text);

}  // namespace kinora
