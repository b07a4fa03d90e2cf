// All plug-ins known to a process: the stock ones (a generated table) and shared libraries found on the plug-in path.
// Called by render/ and app/; it creates nothing and knows no scene.
#pragma once
#include <kinora/plugin.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"
#include "base/digest.h"

namespace kinora {

std::vector<const Descriptor*> stockPlugins();  // generated

class Registry {
 public:
  Registry();  // the stock plug-ins
  ~Registry();
  // Directories looked through for NAME.so when a name is not known; nothing is opened before it is asked for.
  void setPath(std::vector<std::string> directories);
  // Case does not matter. Null when there is none of the name and kind; a library that is there but cannot be used
  // (another ABI, missing symbol) is reported once through `diagnostics`.
  const Descriptor* find(Kind kind, std::string_view name, Diagnostics& diagnostics, const SourcePos& pos);
  // A plug-in that is linked into the program (tests, bindings). The descriptor outlives the registry.
  void add(const Descriptor& plugin);
  // Opens one library; false with a message when it cannot be used.
  bool load(const std::string& file, Diagnostics& diagnostics, const SourcePos& pos);
  // Opens every library of the path (for `kinora plugins`).
  void loadAll(Diagnostics& diagnostics);
  std::vector<const Descriptor*> all(Kind kind) const;
  std::vector<const Descriptor*> all() const;
  // What the library that a plug-in comes from held when it was opened; none for stock plug-ins.
  std::optional<Digest> libraryOf(const Descriptor& plugin) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

const char* nameOf(Kind kind);  // "bxdf", "pattern" ...

// The functions of a descriptor for a SIMD width: the widest table that is not wider than `width` and that this CPU
// runs; null when there is none.
const void* functionsFor(const Descriptor& d, uint32_t width, uint32_t* got = nullptr);

}  // namespace kinora
