#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace hpdm {

class PictureTarget;

/// Where the render loop draws: an OpenGL core context (3.3 or newer) and, with a window, the
/// screen. Everything is called by the render thread, on which the context is constructed.
class RenderContext {
 public:
  virtual ~RenderContext() = default;

  /// The GL renderer and version, such as "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5".
  virtual const std::string& renderer() const = 0;

  /// Whether drawing still reaches this context: it is current on the calling thread, was not
  /// reset, and GL has recorded no error. Otherwise one line that says what happened; empty when
  /// all is well. Clears GL's error flags. Waits for nothing.
  virtual std::string Failure() const = 0;

  /// Makes the context current on the calling thread again, after other code has taken it away;
  /// false when it is lost. GL objects must not be deleted without a current context.
  virtual bool MakeCurrent() = 0;

  /// Shows a resolved picture to the user, scaled into the middle of a screen of width x height
  /// pixels; does nothing without a screen. Never waits for the screen's refresh.
  virtual void Present(const PictureTarget& picture, int width, int height) = 0;
};

/// Makes the calling thread's context. Throws MachineError when the machine cannot draw.
using RenderContextFactory = std::function<std::unique_ptr<RenderContext>()>;

/// Whether a renderer (GL_RENDERER) draws with the machine's processor.
bool IsSoftwareRenderer(std::string_view renderer);

/// The renderer and version of the current context.
std::string GlRenderer();

/// What the current context has suffered, as RenderContext::Failure says it. A reset of the
/// graphics processor can be asked for only where the context was made to report it.
std::string GlFailure(bool reports_resets);

}  // namespace hpdm
