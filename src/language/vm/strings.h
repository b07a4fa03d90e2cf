// Strings as 32-bit handles, the same text always the same handle within a process. Thread-safe; texts live for ever.
// Handle 0 is the empty string. Handles are for comparing and for looking up, never for ordering or hashing: they
// depend on who asked first.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace kinora::language {

int32_t internString(std::string_view text);
const std::string& stringOf(int32_t handle);  // "" for a handle that was never given out

}  // namespace kinora::language
