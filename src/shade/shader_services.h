// What shaders ask of the renderer, answered for the points of a context. Made for one run.
#pragma once
#include "language/vm/services.h"
#include "shade/context_host.h"

namespace kinora::shade {

class ShaderServices {
 public:
  ShaderServices(const Context* c, ContextHost& host);
  const language::RendererServices& table() const { return table_; }

 private:
  struct Calls;
  language::RendererServices table_;
  const Context* context_;
  ContextHost& host_;
};

}  // namespace kinora::shade
