#include "shade/tees.h"

#include "shade/context_host.h"

namespace kinora::shade {

namespace {

const Program::Tee* find(const Program& p, std::string_view channel) {
  for (const Program::Tee& t : p.tees)
    if (t.channel == channel) return &t;
  return nullptr;
}

}  // namespace

Value teeValue(const Context* c, std::string_view channel) {
  ContextHost& h = ContextHost::of(c);
  const Program::Tee* tee = h.program ? find(*h.program, channel) : nullptr;
  if (!tee) return {};
  h.evaluate(c, tee->node);
  return h.outputs[h.firstOutput[tee->node] + tee->output];
}

bool hasTee(const MaterialSet& materials, std::string_view channel) {
  for (uint32_t i = 0; i < materials.programCount(); ++i)
    if (find(materials.program(i), channel)) return true;
  return false;
}

}  // namespace kinora::shade
