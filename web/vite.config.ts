import { defineConfig } from 'vitest/config';

// `npm run dev` proxies to a service (the mock, or `ugoki studio --port 7117`); its address comes from the environment.
const service = process.env.UGOKI_SERVICE ?? 'http://127.0.0.1:7117';

export default defineConfig({
  base: './',
  esbuild: { jsx: 'automatic' },
  build: {
    outDir: 'dist',
    target: 'es2022',
    chunkSizeWarningLimit: 2000,
    rollupOptions: {
      output: {
        manualChunks: { three: ['three'], ui: ['react', 'react-dom', 'react-dom/client', 'dockview'] },
      },
    },
  },
  server: {
    proxy: {
      '/api': { target: service, changeOrigin: true },
      '/ws': { target: service, ws: true, changeOrigin: true },
    },
  },
  test: { environment: 'node', include: ['test/**/*.test.{ts,mjs}'] },
});
