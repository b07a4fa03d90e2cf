// The version that files and messages name.
#pragma once
namespace kinora {
inline constexpr const char* kVersion = KINORA_VERSION;
}
