// The name that was probably meant. Used where a person's word is looked up in a list: options, parameters, codes.
#pragma once
#include <string>
#include <vector>

namespace kinora {

// "did you mean X?" for the name with the fewest edits (without case); "" when none is near.
std::string didYouMean(const std::string& name, const std::vector<std::string>& names);

}  // namespace kinora
