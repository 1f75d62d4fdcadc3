#include "render/gl/egl_context.h"

// epoxy's EGL header must come before its GL header.
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/text_list.h"

namespace hpdm {
namespace {

constexpr int kMaxDevices = 16;

struct Candidate {
  const char* name;
  EGLDisplay display;
};

bool HasClientExtension(const char* extension) {
  return epoxy_has_egl_extension(EGL_NO_DISPLAY, extension);
}

/// Returns the displays to try, best first.
std::vector<Candidate> Candidates() {
  std::vector<Candidate> candidates;
  if (HasClientExtension("EGL_EXT_platform_base")) {
    if (HasClientExtension("EGL_MESA_platform_surfaceless")) {
      candidates.push_back({"surfaceless", eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                                                    EGL_DEFAULT_DISPLAY, nullptr)});
    }
    const bool enumerates = HasClientExtension("EGL_EXT_device_base") ||
                            HasClientExtension("EGL_EXT_device_enumeration");
    if (enumerates && HasClientExtension("EGL_EXT_platform_device")) {
      std::array<EGLDeviceEXT, kMaxDevices> devices{};
      EGLint count = 0;
      if (!eglQueryDevicesEXT(kMaxDevices, devices.data(), &count)) count = 0;
      for (int d = 0; d < count; ++d) {
        candidates.push_back(
            {"device", eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[d], nullptr)});
      }
    }
  }
  candidates.push_back({"default", eglGetDisplay(EGL_DEFAULT_DISPLAY)});
  return candidates;
}

std::string EglError(const char* call) {
  char text[64];
  std::snprintf(text, sizeof text, "%s failed (EGL error 0x%04x)", call,
                static_cast<unsigned>(eglGetError()));
  return text;
}

}  // namespace

EglContext::EglContext() {
  constexpr const char* kRemedy =
      "; install the packages libegl-mesa0 and libgl1-mesa-dri (software rendering suffices), or "
      "run without pictures";
  if (!epoxy_has_egl()) throw MachineError(std::string("EGL: no library found") + kRemedy);
  std::string reasons;
  for (const Candidate& candidate : Candidates()) {
    std::string reason;
    if (TryDisplay(candidate.display, &reason)) return;
    Release();
    AppendToList(std::string(candidate.name) + ": " + reason, &reasons);
  }
  throw MachineError("EGL: no OpenGL 3.3 context (" + reasons + ")" + kRemedy);
}

EglContext::~EglContext() { Release(); }

void EglContext::Release() {
  if (display_ != nullptr) {
    if (context_ != nullptr && eglGetCurrentContext() == context_) {
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
    if (surface_ != nullptr) eglDestroySurface(display_, surface_);
    if (context_ != nullptr) eglDestroyContext(display_, context_);
    eglReleaseThread();
  }
  display_ = context_ = surface_ = nullptr;
}

bool EglContext::TryDisplay(void* display, std::string* reason) {
  const auto fail = [reason](const std::string& why) {
    *reason = why;
    return false;
  };
  if (display == EGL_NO_DISPLAY) return fail("no display");
  if (!eglInitialize(display, nullptr, nullptr)) return fail(EglError("eglInitialize"));
  display_ = display;
  if (!eglBindAPI(EGL_OPENGL_API)) return fail("OpenGL is not supported");

  const EGLint config_attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                      EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint config_count = 0;
  if (!eglChooseConfig(display, config_attributes, &config, 1, &config_count)) {
    return fail(EglError("eglChooseConfig"));
  }
  if (config_count == 0) return fail("no configuration draws OpenGL off screen");

  // First with notification of resets of the graphics processor, which some drivers lack.
  for (const bool robust : {true, false}) {
    const EGLint attributes[] = {
        EGL_CONTEXT_MAJOR_VERSION_KHR,
        3,
        EGL_CONTEXT_MINOR_VERSION_KHR,
        3,
        EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
        robust ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_KHR : EGL_NONE,
        EGL_LOSE_CONTEXT_ON_RESET_KHR,
        EGL_NONE};
    context_ = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    reports_resets_ = robust;
    if (context_ != EGL_NO_CONTEXT) break;
  }
  if (context_ == EGL_NO_CONTEXT) return fail(EglError("eglCreateContext"));

  // All drawing goes to framebuffer objects; the surface only satisfies eglMakeCurrent.
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) {
    const EGLint surface_attributes[] = {EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE};
    surface_ = eglCreatePbufferSurface(display, config, surface_attributes);
    if (surface_ == EGL_NO_SURFACE) return fail(EglError("eglCreatePbufferSurface"));
  }
  if (!MakeCurrent()) return fail(EglError("eglMakeCurrent"));

  renderer_ = GlRenderer();
  return true;
}

bool EglContext::MakeCurrent() {
  return eglMakeCurrent(display_, surface_, surface_, context_) == EGL_TRUE;
}

std::string EglContext::Failure() const {
  if (eglGetCurrentContext() != context_) {
    return "the OpenGL context is no longer current on the render thread";
  }
  return GlFailure(reports_resets_);
}

std::unique_ptr<RenderContext> HeadlessContext() { return std::make_unique<EglContext>(); }

}  // namespace hpdm

#if defined(__SANITIZE_THREAD__)
/// Mesa's software renderer is not instrumented. The race detector cannot see the counters that
/// order its workers' use of a fence, and reports the fence's destruction as a race. Suppresses
/// only reports with Mesa's own code in the stack.
extern "C" const char* __tsan_default_suppressions() {
  return "race:swrast_dri.so\nrace:libgallium\n";
}
#endif
