// Plug-ins that files name and this version does not have, with the reason: one table for the messages of a scene that
// asks for one (PLUGIN-MISSING) and for the manual (docs/plugins.md). It knows nothing of stand-ins, which are those
// who ask's.
#pragma once
#include <kinora/plugin.h>

#include <span>
#include <string>
#include <string_view>

namespace kinora {

struct RefusedPlugin {
  Kind kind;
  const char* name;
  const char* why;
  const char* instead;  // what to use; "": nothing
};

// By kind, in the order of Kind, then by name.
std::span<const RefusedPlugin> refusedPlugins();

// What to tell about a plug-in that is not found: why it is refused and what to use, or, of a name that nobody knows,
// whether its library is on the path.
std::string adviceOnMissing(Kind kind, std::string_view name);

}  // namespace kinora
