// Strings as source and .oso files spell them.
#pragma once
#include <string>

namespace kinora::language {

// In quotes, with the escapes of C.
std::string inQuotes(const std::string&);

}  // namespace kinora::language
