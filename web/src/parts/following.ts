import { useEffect, useLayoutEffect, useRef } from "preact/hooks";

/** Keeps the list inside the element at its end while the user is there. After scrolling up, nothing moves. */
export function useFollowing(some: boolean, version: unknown, following: boolean, setFollowing: (on: boolean) => void) {
  const box = useRef<HTMLDivElement>(null);
  const list = () => box.current?.querySelector<HTMLElement>(".list");
  useLayoutEffect(() => {
    const element = list();
    if (element && following) element.scrollTop = element.scrollHeight;
  }, [version, following]);
  useEffect(() => {
    const element = list();
    if (!element) return undefined;
    let before = element.scrollTop;
    const scrolled = () => {
      const atEnd = element.scrollTop + element.clientHeight >= element.scrollHeight - 40;
      if (atEnd) setFollowing(true);
      else if (element.scrollTop < before) setFollowing(false); // by the scrollbar: there is no other event
      before = element.scrollTop;
    };
    const left = (event: Event) => {
      if (!(event instanceof WheelEvent) || event.deltaY < 0) setFollowing(false);
    };
    element.addEventListener("scroll", scrolled);
    element.addEventListener("wheel", left, { passive: true });
    element.addEventListener("touchmove", left, { passive: true });
    element.addEventListener("keydown", left);
    return () => {
      element.removeEventListener("scroll", scrolled);
      element.removeEventListener("wheel", left);
      element.removeEventListener("touchmove", left);
      element.removeEventListener("keydown", left);
    };
  }, [some]);
  return box;
}
