// Names that scenes give and that this renderer understands, but that change nothing here: a scene that asks for
// something by them is told so, once a name. Used by the interpreter; it reports nothing itself.
#pragma once
#include <string>
#include <string_view>

#include "scene/parameters.h"

namespace kinora::rib {

enum class Where { Hider, Option, Attribute, Display };

// Why `p` has no effect, with what does the same here where something does; null where it has one, where nobody knows
// the name, or where its value asks for what is done anyway. Names are "adaptall", and "checkpoint:asfinal" of what
// stands in a group.
const char* whyNoEffect(Where where, std::string_view name, const scene::Parameter& p);

// What happens in place of what a hider by this name would have made; null: it makes the camera's picture.
const char* otherHider(std::string_view name);

}  // namespace kinora::rib
