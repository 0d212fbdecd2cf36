import sys; sys.path.insert(0,'/work/wt')
from judge import *
import judge
def quiet(s): return [x for x in s if not x.startswith("adc.noise")]+["adc.noise_a=0"]
def holdq(motor,w,**k):
    old=judge.base
    def b2(*a,**kk):
        s,F,K,h,c=old(*a,**kk); return quiet(s),F,K,h,c
    judge.base=b2
    try: return "Q "+judge.hold(motor,w,**k)
    finally: judge.base=old
def jobs2():
    for w in W: yield holdq,("re25-118743",w),{}
    for w in W[:3]: yield hold,("re25-118743",w),{}
    for w in ("0","----"): yield holdq,("re25-118743",w),dict(load_j=10,hand_b=.1e-3)
    for w in ("0","++++"): yield holdq,("re25-118743",w),dict(load_j=10,hand_b=2e-3)
    for w in ("----","+-+-"): yield hold,("re25-118743",w),dict(force_w=3.2,more=["thermal.start_c=125","thermal.ambient_c=100","thermal.magnet_per_k=-0.0011"],tag=" hot")
    for f in (.5,1.5,4):
        for w in ("0","----"): yield press,("re25-118743",f,w),{}
if __name__=="__main__":
    J=list(jobs2()); print(call(J[0]),flush=True)
    with Pool(2) as p:
        for r in p.imap(call,J[1:]): print(r,flush=True)
