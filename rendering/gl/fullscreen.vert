#version 450 core
// One triangle over the whole framebuffer, from gl_VertexID alone: draw 3 vertices, no attributes.
// Inputs: none. Output: clip positions (-1,-1), (3,-1), (-1,3). CPU twin: a loop over all pixels.
void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
