// The sequences behind kinora/random.h. Made once, at first use.
#pragma once
#include <kinora/sample_table.h>

namespace kinora {
const SampleTable& pmj02Table();
}
