// getattribute() and surfacearea(): primvars, built-in variables, attributes of objects, the camera. Used by
// ShaderServices.
#pragma once
#include "language/vm/services.h"
#include "shade/context_host.h"

namespace kinora::shade {

void giveAttribute(const Context* c, ContextHost& host, const language::Batch& batch, language::Span object,
                   language::Span name, language::Span index, language::Span to, language::Span found);
void giveSurfaceArea(const Context* c, ContextHost& host, const language::Batch& batch, language::Span result);

}  // namespace kinora::shade
