// Passes over a flattened program: constants folded by the machine's own kernels, copies followed, conditions that
// are known decided, calls without early ends opened, and what nothing reads removed. The answer has the same bits.
#pragma once
#include "language/optimise/group.h"

namespace kinora::language {

void linkMessages(FlatProgram&);       // messages.cpp, the last step of flatten()
void makeClosureValues(FlatProgram&);  // closure_values.cpp, before the other passes
void optimise(FlatProgram&);
void chooseNames(FlatProgram&);   // choose_names.cpp, behind the other passes: what they could not know
void renameValues(FlatProgram&);  // rename.cpp, a pass of optimise()

// The values that a layer's settings give to a parameter, in `type`; `values` stays when there is none.
void settingValues(const Layer&, const std::string& parameter, const Type& type, Values& values);

}  // namespace kinora::language
