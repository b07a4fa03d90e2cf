// An integrator whose create() lets an exception out, against the contract.
#include <kinora/bxdf.h>
#include <kinora/integrator.h>

#include <stdexcept>

namespace kinora {
namespace {
void integrate(const void*, uint32_t, Group*, const Services*) {}
void* create(const CreateInfo*, ErrorText*) { throw std::runtime_error("this one always throws"); }
constexpr IntegratorFunctions kFunctions{&integrate};
const WidthTable kTables[] = {{1, &kFunctions}};
const Descriptor kDescriptor{kAbiVersion,      sizeof(Descriptor),
                             Kind::Integrator, 0,
                             "Throws",         "Throws when created.",
                             nullptr,          0,
                             kTables,          1,
                             nullptr,          &create,
                             nullptr};
}  // namespace
KINORA_REGISTER(Throws, kDescriptor)
}  // namespace kinora
