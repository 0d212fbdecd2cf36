import sys; sys.path.insert(0,'/tmp')
from loop import *
def hz(w,out,t0=1.4,t1=1.41,dur=1.5,k0=(),**k):
    s,F,K,h,c=base("re25-118743",w,**k); s+=["hand.path=press",f"hand.amplitude_rad={F/h+F/K}",f"scene.duration_s={dur}",*k0]
    sc=load("held_wall",s); sim=CONTROLLERS["golden"](sc); n=round(dur*1e6)
    rows=np.zeros((n,len(C))); sim.advance(rows,np.zeros((n,len(Word)),dtype=np.int64))
    cell=2*math.pi/10000; sl=slice(int(t0*1e6),int(t1*1e6),2)
    x=rows[sl,C.X]/cell; Fk=-rows[sl,C.TORQUE]/K/cell; t=rows[sl,C.T]
    fig,ax=plt.subplots(3,1,figsize=(16,14),sharex=True)
    ax[0].plot(t,x-x.mean()); ax[0].plot(t,Fk-Fk.mean()); ax[1].plot(t,rows[sl,C.FLUX]); ax[2].plot(t,rows[sl,C.CORRECTION]); [a.grid() for a in ax]
    plt.savefig(out,dpi=50)
if __name__=="__main__": hz(sys.argv[1],sys.argv[2])
