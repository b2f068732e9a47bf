/* bars_d3d11.exe FRAMES: frame numbers by Direct3D 11, for Wine, which draws them by OpenGL. The picture is made by the
 * processor and copied into the back buffer: no shader is needed. */
#define COBJMACROS
#include <windows.h>
#include <initguid.h>
#include <d3d11.h>
#include <stdio.h>
#include <stdlib.h>

enum { kBars = 16, kBorder = 8, kWidth = 640, kHeight = 480 };

static unsigned pixels[kHeight][kWidth];

static void fill(int x, int y, int width, int height, unsigned grey, unsigned colour) {
  int i, j;
  for (j = y; j < y + height; ++j)
    for (i = x; i < x + width; ++i) pixels[j][i] = colour ? colour : 0xFF000000u | grey << 16 | grey << 8 | grey;
}

int main(int argc, char** argv) {
  unsigned number, frames = argc > 1 ? (unsigned)atoi(argv[1]) : 100;
  WNDCLASSA windows = {0};
  windows.lpfnWndProc = DefWindowProcA, windows.lpszClassName = "bars", windows.hInstance = GetModuleHandleA(NULL);
  RegisterClassA(&windows);
  HWND window = CreateWindowA("bars", "bars", WS_POPUP | WS_VISIBLE, 0, 0, kWidth, kHeight, NULL, NULL, windows.hInstance, NULL);
  DXGI_SWAP_CHAIN_DESC how = {0};
  how.BufferDesc.Width = kWidth, how.BufferDesc.Height = kHeight, how.BufferDesc.Format = DXGI_FORMAT_R8G8B8A8_UNORM;
  how.SampleDesc.Count = 1, how.BufferUsage = DXGI_USAGE_RENDER_TARGET_OUTPUT, how.BufferCount = 1;
  how.OutputWindow = window, how.Windowed = TRUE;
  ID3D11Device* device = NULL;
  ID3D11DeviceContext* context = NULL;
  IDXGISwapChain* chain = NULL;
  if (FAILED(D3D11CreateDeviceAndSwapChain(NULL, D3D_DRIVER_TYPE_HARDWARE, NULL, 0, NULL, 0, D3D11_SDK_VERSION, &how, &chain,
                                           &device, NULL, &context)))
    return 2;
  ID3D11Texture2D* back = NULL;
  if (FAILED(IDXGISwapChain_GetBuffer(chain, 0, &IID_ID3D11Texture2D, (void**)&back))) return 2;
  for (number = 1; number <= frames; ++number) {
    int half, i, bar = kWidth / kBars;
    MSG message;
    while (PeekMessageA(&message, NULL, 0, 0, PM_REMOVE)) DispatchMessageA(&message);
    fill(0, 0, kWidth, kHeight, 0, 0);
    for (half = 0; half < 2; ++half)
      for (i = 0; i < kBars; ++i)
        fill(i * bar + bar / 4, half * (kHeight / 2), bar / 2, kHeight / 2, (number >> (kBars - 1 - i)) & 1 ? 255 : 128, 0);
    fill(0, 0, kWidth, kBorder, 0, 0xFF0000FFu); /* red: the lowest byte */
    ID3D11DeviceContext_UpdateSubresource(context, (ID3D11Resource*)back, 0, NULL, pixels, kWidth * 4, 0);
    IDXGISwapChain_Present(chain, 0, 0);
    printf("swap %u\n", number);
    fflush(stdout);
    Sleep(16);
  }
  return 0;
}
