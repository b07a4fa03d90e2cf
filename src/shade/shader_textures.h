// Texture calls of shaders: texture, environment, texture3d, gettextureinfo with all their options, for the points of
// a batch. Used by ShaderServices.
#pragma once
#include "language/vm/services.h"
#include "shade/context_host.h"

namespace kinora::shade {

void lookUpTexture(const Context* c, ContextHost& host, const language::Batch& batch,
                   const language::TextureCall& call);
void lookUpEnvironment(const Context* c, ContextHost& host, const language::Batch& batch,
                       const language::TextureCall& call);
// There are no files of volumes yet: the missing colour, else black.
void lookUpVolume(const Context* c, ContextHost& host, const language::Batch& batch,
                  const language::TextureCall& call);
void giveTextureInfo(const Context* c, ContextHost& host, const language::Batch& batch, language::Span file,
                     language::Span coordinates, language::Span name, language::Span to, language::Span found);

}  // namespace kinora::shade
