// Values by names, for conditions and strings: of attributes and options as they stand, those that classic requests set
// among them ("Ri:Sides"), and what holds where nothing was said. Used by Interpreter::lookUp, which knows the order in
// which all this is asked. It reports nothing.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace kinora::rib {

// Empty where these attributes do not say it. `isMirrored`: the space in which the handedness of Ri:Orientation counts.
std::optional<std::string> attributeValue(std::string_view name, const scene::Attributes& a, bool isMirrored);
std::optional<std::string> optionValue(std::string_view name, const scene::Scene& options,
                                       const scene::Camera& camera);

// Where no request says it; empty for names that have no value then.
std::optional<std::string> usualAttribute(std::string_view name);
std::optional<std::string> usualOption(std::string_view name);

}  // namespace kinora::rib
