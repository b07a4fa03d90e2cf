#include "render/instance.h"

#include <cstdio>
#include <exception>
#include <new>
#include <utility>

#include "base/memory.h"
#include "shade/material.h"
#include "texture/texture_system.h"

namespace kinora::render {

namespace {

// Whose create() this thread is in: messages and images that a plug-in asks for there are about that node.
thread_local const scene::Node* nodeBeingMade = nullptr;
// No exception crosses a plug-in: a size that was refused on its behalf waits here until its create() is over.
thread_local std::exception_ptr refusedSize;

void hostWarn(void* self, const char* code, const char* what, const char* done) {
  static_cast<PluginHost::Parts*>(self)->diagnostics->warning(code, nodeBeingMade ? nodeBeingMade->pos : SourcePos{},
                                                              what, done);
}
const HostImage* hostImage(void* self, const char* file, int linearize) {
  TextureRequest request;
  if (nodeBeingMade) {
    request.pos = nodeBeingMade->pos;
    request.object = nodeBeingMade->plugin + " '" + nodeBeingMade->handle + "'";
  }
  try {
    return static_cast<PluginHost::Parts*>(self)->textures->image(file, linearize, request);
  } catch (const std::bad_alloc&) {
    refusedSize = std::current_exception();
    return nullptr;
  }
}

}  // namespace

PluginHost::PluginHost(Diagnostics& diagnostics, TextureSystem* textures) : parts_{&diagnostics, textures} {
  host_ = Host{&parts_, &hostWarn, &hostImage};
}

bool Instance::create(const Descriptor& plugin, const scene::Node* node, const Placement* placement,
                      const void* extra, const Host& host, Diagnostics& diagnostics) {
  plugin_ = &plugin;
  data_.reset();
  if (!plugin.create) return true;
  const shade::ResolvedParams params(plugin, node, diagnostics);
  CreateInfo info{};
  info.host = &host;
  info.handle = node && !node->handle.empty() ? node->handle.c_str() : plugin.name;
  info.values = params.values();
  info.valueCount = params.count();
  info.placement = placement;
  info.extra = extra;
  ErrorText error{};
  void* made = nullptr;
  nodeBeingMade = node;
  try {
    made = plugin.create(&info, &error);
  } catch (...) {
    // a plug-in that does not use guardedCreate()
    std::snprintf(error.text, sizeof error.text, "exception in create()");
  }
  nodeBeingMade = nullptr;
  if (const std::exception_ptr refused = std::exchange(refusedSize, nullptr)) {
    if (made && plugin.destroy) plugin.destroy(made);
    plugin_ = nullptr;
    std::rethrow_exception(refused);
  }
  if (!made) {
    diagnostics.warning("PLUGIN-CREATE", node ? node->pos : SourcePos{},
                        std::string(plugin.name) + " '" + info.handle +
                            "' cannot be made: " + (error.text[0] ? error.text : "no reason given"),
                        "a fallback is used");
    plugin_ = nullptr;
    return false;
  }
  data_ = std::shared_ptr<void>(made, [destroy = plugin.destroy](void* p) {
    if (destroy) destroy(p);
  });
  Memory::check(MemoryUse::Textures);  // tables over a light's map are the plug-in's own
  return true;
}

}  // namespace kinora::render
