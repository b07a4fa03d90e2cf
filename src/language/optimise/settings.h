// The values that an instance of a shader is given: which of them are compiled in, and their forms. Shared by
// flatten() and structureKey(), which must agree.
#pragma once
#include <string>
#include <vector>

#include "language/optimise/group.h"

namespace kinora::language {

std::string keyOf(const Type& type, const Values& values);  // equal for equal values of equal types
size_t countOf(const Type& type);                           // numbers, ints or strings that a value takes
size_t elementsIn(const Type& type, const Values& values);
// `values` of type `from` as `to`; false when an instance value of that type may not be given.
bool convertSetting(const Type& from, const Values& values, const Type& to, Values& out);

// Which symbols the code of a shader writes, and which ints decide something when the program is made.
struct ShaderFacts {
  std::vector<bool> isWritten, isStructural;
};
ShaderFacts factsOfShader(const Shader& shader);
bool isCompiledIn(const ShaderFacts& facts, const Shader& shader, SymbolId id);
bool isParam(const Symbol& s);
// The last one of that name; null when there is none.
const Setting* settingOf(const Layer& layer, const std::string& name);

}  // namespace kinora::language
