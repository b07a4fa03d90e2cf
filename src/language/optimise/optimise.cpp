#include "language/optimise/optimise.h"

namespace kinora::language {

void optimise(FlatProgram&) {}

}  // namespace kinora::language
