#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace hpdm {

class PictureTarget;

/// The render loop's OpenGL core context (3.3 or newer) and, with a window, its screen. Constructed
/// and called on the render thread.
class RenderContext {
 public:
  virtual ~RenderContext() = default;

  /// Returns the GL renderer and version, such as "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5".
  virtual const std::string& renderer() const = 0;

  /// Returns one line with the failure if the context is not current on the calling thread, was
  /// reset, or has recorded a GL error; otherwise "". Clears GL's error flags. Non-blocking.
  virtual std::string Failure() const = 0;

  /// Makes the context current on the calling thread again, after other code replaced it. False if
  /// it is lost. GL objects must not be deleted without a current context.
  virtual bool MakeCurrent() = 0;

  /// Shows a resolved picture, scaled into the middle of a screen of width x height pixels. Does
  /// nothing without a screen. Never waits for the screen's refresh.
  virtual void Present(const PictureTarget& picture, int width, int height) = 0;
};

/// Makes the calling thread's context. Throws MachineError if the machine cannot draw.
using RenderContextFactory = std::function<std::unique_ptr<RenderContext>()>;

/// True if the renderer (GL_RENDERER) draws on the CPU.
bool IsSoftwareRenderer(std::string_view renderer);

/// Returns the renderer and version of the current context.
std::string GlRenderer();

/// Returns the current context's failure, see RenderContext::Failure. `reports_resets`: the context
/// was created with reset notification.
std::string GlFailure(bool reports_resets);

}  // namespace hpdm
