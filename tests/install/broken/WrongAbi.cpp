// A bxdf of a plug-in interface that does not exist yet: the rest of its descriptor must not be looked at.
#include <kinora/plugin.h>

namespace kinora {
namespace {
const Descriptor* const kNowhere = reinterpret_cast<const Descriptor*>(8);
const Descriptor kDescriptor{kAbiVersion + 1, 16,      Kind::Bxdf, 0,       reinterpret_cast<const char*>(kNowhere),
                             nullptr,         nullptr, 0,          nullptr, 0,
                             nullptr,         nullptr, nullptr};
}  // namespace
KINORA_REGISTER(WrongAbi, kDescriptor)
}  // namespace kinora
