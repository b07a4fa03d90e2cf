// All message codes of the program: the tables of the rooms it links and app/'s own. Used by `kinora explain` and by
// the test that no code is printed that cannot be explained.
#pragma once
#include "base/explain.h"

namespace kinora::app {

Explanations allExplanations();

}  // namespace kinora::app
